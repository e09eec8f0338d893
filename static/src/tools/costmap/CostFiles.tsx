import type { BrushStroke } from "../../wire/protocol";
import { FileButton } from "../files/FileButton";

interface CostFilesProps {
  readonly session: string;
  /** The painted strokes. */
  readonly strokes?: readonly BrushStroke[];
}

const COSTS = [
  ["costmap.pgm", "pgm"],
  ["costmap.yaml", "yaml"],
  ["costmap.mcap", "mcap"],
] as const;
const KEEPOUT = [
  ["keepout.pgm", "Keepout pgm"],
  ["keepout.yaml", "Keepout yaml"],
] as const;
const SPEED = [
  ["speed.pgm", "Speed limits pgm"],
  ["speed.yaml", "Speed limits yaml"],
] as const;

/** The current costs of a session as files, and the painted zones as a mask. */
export function CostFiles({ session, strokes = [] }: CostFilesProps) {
  const painted = strokes.filter(({ erases }) => !erases);
  const hasKeepout = painted.some(({ speed }) => speed == null);
  const hasSpeed = painted.some(({ speed }) => speed != null);
  return (
    <>
      <div class="actions">
        {[...COSTS, ...(hasKeepout ? KEEPOUT : []), ...(hasSpeed ? SPEED : [])].map(([file, label]) => (
          <FileButton key={file} session={session} file={`costmap/${file}`}>
            {label}
          </FileButton>
        ))}
      </div>
      <p class="navigation-note">
        The greys of the pgm are the costs, 0 to 255. The mcap has nav2_msgs/Costmap and nav_msgs/OccupancyGrid.
        {painted.length > 0 && " The painted zones are masks of Nav2’s keepout filter and speed filter."}
      </p>
    </>
  );
}
