"""Error against run time of whole renders, ours and others', against a reference."""
