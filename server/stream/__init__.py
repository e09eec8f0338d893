"""The stream: the wire format, the layers, and what each client has received."""
