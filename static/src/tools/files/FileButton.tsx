import type { ComponentChildren } from "preact";
import { Button } from "../../ui/Button";
import { fileAddress, type SessionFile } from "../../wire/ask";

interface FileButtonProps {
  readonly session: string;
  readonly file: SessionFile;
  /** Accessible name and title, if the text is not sufficient. */
  readonly label?: string;
  readonly kind?: "quiet";
  readonly children: ComponentChildren;
}

/** A button that downloads a file of a session. */
export const FileButton = ({ session, file, ...shown }: FileButtonProps) => (
  <Button icon="download" href={fileAddress(session, file)} download {...shown} />
);
