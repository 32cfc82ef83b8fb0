"""What is doubtful about a spec: rules that read it, and a dry run that builds some of its scenes."""
