/** Resolves when every font of the page has been loaded or has failed, at the latest after `ms` milliseconds. */
export const fontsLoaded = (ms: number): Promise<unknown> =>
  Promise.race([
    Promise.allSettled([...document.fonts].map((font) => font.load())),
    new Promise((done) => setTimeout(done, ms)),
  ]);
