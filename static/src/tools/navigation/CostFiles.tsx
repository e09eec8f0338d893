import { Button } from "../../ui/Button";

interface CostFilesProps {
  readonly session: string;
  /** Whether keepout zones are painted. */
  readonly hasZones?: boolean;
}

const COSTS = [
  ["costmap.pgm", "pgm"],
  ["costmap.yaml", "yaml"],
  ["costmap.mcap", "mcap"],
] as const;
const ZONES = [
  ["keepout.pgm", "Keepout pgm"],
  ["keepout.yaml", "Keepout yaml"],
] as const;

/** The present costs of a session as files, and the painted zones as a mask. */
export function CostFiles({ session, hasZones = false }: CostFilesProps) {
  return (
    <>
      <div class="navigation-row">
        {[...COSTS, ...(hasZones ? ZONES : [])].map(([file, label]) => (
          <Button
            key={file}
            icon="download"
            href={`/api/sessions/${encodeURIComponent(session)}/costmap/${file}`}
            download
          >
            {label}
          </Button>
        ))}
      </div>
      <p class="navigation-note">
        The greys of the pgm are the costs, 0 to 255. The mcap has nav2_msgs/Costmap and nav_msgs/OccupancyGrid.
        {hasZones && " The keepout files are the painted zones as a mask for Nav2’s keepout filter."}
      </p>
    </>
  );
}
