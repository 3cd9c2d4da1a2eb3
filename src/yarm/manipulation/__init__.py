"""Hands: the youBot's arm understood, and ways over a floor that leave nothing out."""
