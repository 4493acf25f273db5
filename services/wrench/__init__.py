"""Wrench sensing: from raw readings of the wrist's sensor to the external wrench at the tool with its error bound."""
