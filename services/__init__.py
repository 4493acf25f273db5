"""The processes of tandem, one package each; they share `shared` and never import one another."""
