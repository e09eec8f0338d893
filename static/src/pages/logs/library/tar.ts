/** Several files as one upload: a tar archive (POSIX.1-2017, pax: the ustar format), without copying the files. */

const BLOCK = 512;

/** The archive of `files`, which has `name`. The same files give the same bytes. */
export function tarred(files: readonly File[], name: string): File {
  const parts = files.flatMap((file) => [header(file), file, new Uint8Array(-file.size & (BLOCK - 1))]);
  return new File([...parts, new Uint8Array(2 * BLOCK)], name);
}

function header(file: File): Uint8Array<ArrayBuffer> {
  const block = new Uint8Array(BLOCK);
  const put = (at: number, text: string): void => block.set(new TextEncoder().encode(text), at);
  block.set(new TextEncoder().encode(file.name).slice(-100)); // the end of the name contains the number of the part
  put(100, "0000644\0");
  put(124, file.size.toString(8).padStart(11, "0"));
  put(148, " ".repeat(8));
  put(156, "0");
  put(257, "ustar\0");
  put(263, "00");
  const sum = block.reduce((all, byte) => all + byte, 0);
  put(148, `${sum.toString(8).padStart(6, "0")}\0`);
  return block;
}
