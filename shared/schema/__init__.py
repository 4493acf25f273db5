"""How a message is declared and checked."""
