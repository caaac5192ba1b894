"""From images back to scenes: what derivatives are for, and how right they are."""
