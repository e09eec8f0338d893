"""The bytes of a log's file: of a member of an archive, packed or plain, in pieces and with caps."""
