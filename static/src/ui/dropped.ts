/** What was dropped on a page: its files, and those in its folders. */

/** Files of a folder that are looked at: more is a mistake, and would stop the page. */
const MOST = 500;

/** All files of a drop, folder by folder. To be called while the drop is handled: later the browser takes them away. */
export function droppedFiles(transfer: DataTransfer): Promise<readonly File[]> {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.() ?? null);
  const plain = [...transfer.files];
  if (!entries.some((entry) => entry?.isDirectory)) return Promise.resolve(plain);
  return filesIn(entries.filter((entry) => entry !== null));
}

/** All files of these entries and of the folders among them, up to {@link MOST}; what cannot be read is left out. */
export async function filesIn(entries: readonly FileSystemEntry[]): Promise<readonly File[]> {
  const found: File[] = [];
  const waiting = [...entries].reverse();
  for (let entry = waiting.pop(); entry && found.length < MOST; entry = waiting.pop()) {
    try {
      if (entry.isDirectory) waiting.push(...(await children(entry as FileSystemDirectoryEntry)).reverse());
      else found.push(await new Promise<File>((done, fail) => (entry as FileSystemFileEntry).file(done, fail)));
    } catch {
      // gone meanwhile, or not to be read
    }
  }
  return found;
}

/** What is in a folder, by name. The browser gives it in parts, the last of which is empty. */
async function children(folder: FileSystemDirectoryEntry): Promise<FileSystemEntry[]> {
  const reader = folder.createReader();
  const found: FileSystemEntry[] = [];
  for (;;) {
    const part = await new Promise<FileSystemEntry[]>((done, fail) => reader.readEntries(done, fail));
    if (part.length === 0) return found.sort((a, b) => a.name.localeCompare(b.name, "en", { numeric: true }));
    found.push(...part);
  }
}
