"""Other people's spheres, where they are installed."""
