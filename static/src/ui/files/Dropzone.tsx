import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useRef } from "preact/hooks";
import { Icon } from "../Icon";
import { droppedFiles, type Folder } from "./droppedFiles";

interface DropzoneProps {
  readonly onFolders: (folders: readonly Folder[]) => void;
  readonly button: string;
  readonly children: ComponentChildren;
}

/** A drop zone for files and folders, with a file picker. */
export function Dropzone({ onFolders, button, children }: DropzoneProps) {
  const depth = useSignal(0);
  const input = useRef<HTMLInputElement>(null);
  return (
    <section
      class={`dropzone${depth.value > 0 ? " over" : ""}`}
      aria-label="Upload"
      onDragEnter={(event) => {
        event.preventDefault();
        depth.value++;
      }}
      onDragOver={(event) => event.preventDefault()}
      onDragLeave={() => {
        depth.value--;
      }}
      onDrop={(event) => {
        event.preventDefault();
        depth.value = 0;
        if (event.dataTransfer) void droppedFiles(event.dataTransfer).then(onFolders);
      }}
    >
      <Icon name="upload" />
      {children}
      <input
        ref={input}
        class="visually-hidden dropzone-input"
        type="file"
        multiple
        aria-label={button}
        onChange={(event) => {
          onFolders([{ name: "", files: [...(event.currentTarget.files ?? [])] }]);
          event.currentTarget.value = "";
        }}
      />
      <button type="button" class="button primary" tabIndex={-1} onClick={() => input.current?.click()}>
        {button}
      </button>
    </section>
  );
}
