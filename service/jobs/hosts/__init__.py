"""Workers on other machines: what a host and the dispatcher say to each other, and over what."""
