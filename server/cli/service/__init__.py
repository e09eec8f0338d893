"""``serve``, ``upload``, ``notes``, ``backup`` and ``restore``: the service, and commands that connect to one."""
