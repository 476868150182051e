"""Whether the runs of a campaign agree with one another and with what hulls usually are."""
