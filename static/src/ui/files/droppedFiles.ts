/** Files and folders that were dropped on a page. */

/** Greatest number of files that are read from dropped folders: more would block the page. */
const MOST = 500;

/** The files of a dropped folder, or, with an empty name, files that were dropped or chosen without a folder. */
export interface Folder {
  readonly name: string;
  readonly files: readonly File[];
}

/** All files of a drop, by folder. Must be called in the drop event's handler: later the items are not available. */
export function droppedFiles(transfer: DataTransfer): Promise<readonly Folder[]> {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.() ?? null);
  const plain = [...transfer.files];
  if (!entries.some((entry) => entry?.isDirectory)) return Promise.resolve([{ name: "", files: plain }]);
  return filesIn(entries.filter((entry) => entry !== null));
}

/** All files of these entries and of the folders among them, up to {@link MOST}; what cannot be read is left out. */
export async function filesIn(entries: readonly FileSystemEntry[]): Promise<readonly Folder[]> {
  let count = 0;
  const loose: File[] = [];
  const folders: Folder[] = [{ name: "", files: loose }];
  const waiting = entries.map((entry) => ({ entry, beside: loose })).reverse();
  for (let next = waiting.pop(); next && count < MOST; next = waiting.pop()) {
    const { entry, beside } = next;
    try {
      if (entry.isDirectory) {
        const files: File[] = [];
        folders.push({ name: entry.name, files });
        const inside = await children(entry as FileSystemDirectoryEntry);
        waiting.push(...inside.map((child) => ({ entry: child, beside: files })).reverse());
      } else {
        beside.push(await new Promise<File>((done, fail) => (entry as FileSystemFileEntry).file(done, fail)));
        count++;
      }
    } catch {
      // deleted in the meantime, or not readable
    }
  }
  return folders.filter((folder) => folder.files.length > 0);
}

/** The entries of a folder, sorted by name. The browser returns them in parts, the last of which is empty. */
async function children(folder: FileSystemDirectoryEntry): Promise<FileSystemEntry[]> {
  const reader = folder.createReader();
  const entries: FileSystemEntry[] = [];
  for (;;) {
    const part = await new Promise<FileSystemEntry[]>((done, fail) => reader.readEntries(done, fail));
    if (part.length === 0) return entries.sort((a, b) => a.name.localeCompare(b.name, "en", { numeric: true }));
    entries.push(...part);
  }
}
