/** How long a connection may take to be accepted, ms. */
export const CONNECT_MS = 20_000;

/**
 * Open a WebSocket; one that the server has not accepted after {@link CONNECT_MS} is closed, so that its owner tries
 * again. A browser waits longer for an answer that was lost: Chromium 240 s.
 */
export function openSocket(url: string, protocol: string): WebSocket {
  const socket = new WebSocket(url, protocol);
  const timer = setTimeout(() => socket.close(), CONNECT_MS);
  const stop = (): void => clearTimeout(timer);
  socket.addEventListener("open", stop);
  socket.addEventListener("close", stop);
  return socket;
}
