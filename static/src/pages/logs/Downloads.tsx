import { FileButton } from "../../tools/files/FileButton";
import { MapFiles } from "../../tools/files/MapFiles";
import { EditMap } from "../../tools/mapediting/EditMap";
import { Button } from "../../ui/Button";
import { Panel } from "../../ui/Panel";
import { fileAddress } from "../../wire/ask";

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
        {!isGuest && (
          <>
            <FileButton session={session} file="run.mcap">
              mcap
            </FileButton>
            <FileButton session={session} file="trajectory.tum">
              Trajectory (TUM)
            </FileButton>
            <Button icon="file" href={fileAddress(session, "report")} target="_blank">
              Report
            </Button>
            <Button icon="file" href={fileAddress(session, "report.pdf")} target="_blank">
              Report as PDF
            </Button>
            <EditMap session={session} name={title} />
          </>
        )}
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
