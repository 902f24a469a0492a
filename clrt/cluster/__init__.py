"""Pictures by many processes: tasks, the workers that do them, and who hands them out."""
