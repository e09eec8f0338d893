/** How long a connection may take to be accepted, ms. */
export const CONNECT_MS = 20_000;

/**
 * Open a WebSocket. If the server has not accepted it after {@link CONNECT_MS}, it is closed, so that its owner tries
 * again. A browser would wait longer for a lost answer: Chromium 240 s.
 */
export function openSocket(url: string, protocol: string): WebSocket {
  const socket = new WebSocket(url, protocol);
  const timer = setTimeout(() => socket.close(), CONNECT_MS);
  const stop = (): void => clearTimeout(timer);
  socket.addEventListener("open", stop);
  socket.addEventListener("close", stop);
  return socket;
}
