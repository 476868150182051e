"""Mean forces of second order: added resistance and drift."""
