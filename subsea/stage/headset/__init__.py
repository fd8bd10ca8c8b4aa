"""Headsets: the runtime's session, its eyes and hands."""
