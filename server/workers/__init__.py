"""Several worker processes of one service on one port: ``gridbloom serve --workers``.

A session, and everything that its visitor does outside of it, belongs to one worker. Every worker accepts connections;
a request for another worker is handed over with its connection (:mod:`server.workers.handover`).
"""
