import { EditMap } from "../../tools/mapediting/EditMap";
import { Button } from "../../ui/Button";
import { MapFiles } from "../../ui/files/MapFiles";
import { Panel } from "../../ui/Panel";

/** Downloads of the log for visitors who may open it. */
const RUN_FILES = ["run.mcap", "trajectory.tum"];
const LABELS: Readonly<Record<string, string>> = { "trajectory.tum": "Trajectory (TUM)" };

/** The map as files and, except for a guest, the run. */
export function Downloads({
  session,
  title,
  isGuest,
}: {
  readonly session: string;
  readonly title: string;
  readonly isGuest: boolean;
}) {
  return (
    <Panel title="Download">
      <div class="actions downloads">
        <MapFiles session={session} />
        {(isGuest ? [] : RUN_FILES).map((name) => (
          <Button key={name} icon="download" href={`/api/sessions/${encodeURIComponent(session)}/${name}`} download>
            {LABELS[name] ?? name.split(".").at(-1)}
          </Button>
        ))}
        {!isGuest && (
          <>
            <Button icon="file" href={`/api/sessions/${encodeURIComponent(session)}/report`} target="_blank">
              Report
            </Button>
            <Button icon="file" href={`/api/sessions/${encodeURIComponent(session)}/report.pdf`} target="_blank">
              Report as PDF
            </Button>
          </>
        )}
        {!isGuest && <EditMap session={session} name={title} />}
      </div>
      <p class="quiet">
        pgm and yaml together are a map for map_server and Nav2; both show the map at the moment of the first download.
        png is an image of the map.
        {!isGuest &&
          " mcap contains the scans, the poses and this map for Rerun and ROS 2, and for Foxglove and Lichtblick, where the topics /map, /scan and /pose are enabled in the 3D panel."}
      </p>
    </Panel>
  );
}
