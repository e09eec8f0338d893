import { Button } from "../../../ui/Button";
import type { ContentsState } from "../contents/useContents";
import { isCloud } from "../library/describeLog";

interface OpenIn3dProps {
  /** Of the log. */
  readonly id: string;
  readonly contents: ContentsState;
}

/** Opens the map in 3D of a log's point clouds, in a tab of its own; nothing for a log that has none. */
export function OpenIn3d({ id, contents }: OpenIn3dProps) {
  const topics = contents.kind === "ready" ? contents.contents.topics : [];
  if (!topics.some(({ type, messages }) => isCloud(type) && messages > 0)) return null;
  return (
    <Button
      icon="cube"
      label="Open in 3D"
      href={`/logs.html?${new URLSearchParams({ log: id, volume: "" })}`}
      target="_blank"
    />
  );
}
