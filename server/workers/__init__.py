"""Several worker processes of one service on one port: ``gridbloom serve --workers``.

A session, and all that its visitor does without one, is in one of them. Every worker accepts connections; a request for
another one is passed on with its connection (:mod:`server.workers.handover`).
"""
