"""Good files of further formats, which `scripts.studies.damage` damages: a file a reader."""
