"""The commands of `subsea-capture`, one file each."""
