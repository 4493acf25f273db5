"""Shared by every process of tandem."""
