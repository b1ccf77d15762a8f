"""Cases of the stability atlas."""
