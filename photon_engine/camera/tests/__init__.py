"""Filters, apertures and rays against their densities and closed forms."""
