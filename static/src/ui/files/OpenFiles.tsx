import type { ComponentChildren } from "preact";
import { useRef } from "preact/hooks";
import { Button } from "../Button";

interface OpenFilesProps {
  /** Accessible name of the field. */
  readonly label: string;
  /** Called with at least one file. */
  readonly onFiles: (files: readonly [File, ...File[]]) => void;
  readonly accept?: string;
  readonly multiple?: boolean;
  readonly kind?: "quiet";
  readonly disabled?: boolean;
  readonly children: ComponentChildren;
}

/** A button that opens the dialog for files; the same file can be chosen again. */
export function OpenFiles({ label, onFiles, kind, disabled = false, children, ...field }: OpenFilesProps) {
  const input = useRef<HTMLInputElement>(null);
  return (
    <>
      <input
        ref={input}
        type="file"
        hidden
        aria-label={label}
        {...field}
        onChange={({ currentTarget }) => {
          const [first, ...others] = currentTarget.files ?? [];
          currentTarget.value = "";
          if (first) onFiles([first, ...others]);
        }}
      />
      <Button kind={kind} icon="upload" disabled={disabled} onClick={() => input.current?.click()}>
        {children}
      </Button>
    </>
  );
}
