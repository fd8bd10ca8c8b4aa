"""Names of computers, for theatre files and keys."""

# ASCII, because files are named so; `\Z`, because `$` would accept a final line break.
NAME = r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}\Z"
