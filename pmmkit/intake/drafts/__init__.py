"""Drafts of campaign files: what names and records of the files of a folder say of the tests."""
