"""What a log holds and how good it is: ``info``, ``doctor``, ``check``, ``report`` and ``fleet``."""
