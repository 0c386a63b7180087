"""The progressive loop: what next, when to stop, what to say."""
