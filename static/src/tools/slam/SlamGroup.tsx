/** SLAM of the lab's robot while it drives with drifting wheels. */

import { useEffect } from "preact/hooks";
import { columnOf, type LayerContent, OVERLAYS, type Overlay } from "../../render/picture/overlays";
import type { Store } from "../../store/store";
import { written } from "../../ui/numbers";
import { Toggle } from "../../ui/Toggle";
import { FAULTS } from "../faults/model";
import { turnFault } from "../faults/turn";
import "./poseGraph";
import "./slam.css";
import { toScreen } from "../../render/view";

/** Style of the layer. */
const STYLE = "true_path";
/** Metres between two scans: no drive is as fast, so the robot was placed elsewhere. */
const CARRIED = 2;

const paintTruePath: Overlay = ({ ctx, view, size, colours }, content) => {
  const xs = columnOf(content, "x");
  const ys = columnOf(content, "y");
  if (!xs || !ys) return;
  const [x0, y0] = toScreen(view, size, 0, 0);
  ctx.beginPath();
  let [lastX, lastY] = [Number.POSITIVE_INFINITY, 0];
  for (let i = 0; i < xs.length; i++) {
    const [x, y] = [xs[i] as number, ys[i] as number];
    const at = [x0 + x / view.scale, y0 - y / view.scale] as const;
    if (Math.hypot(x - lastX, y - lastY) < CARRIED) ctx.lineTo(...at);
    else ctx.moveTo(...at);
    [lastX, lastY] = [x, y];
  }
  for (const [width, colour, dash] of [
    [4, colours.halo, []],
    [2, colours.outline, [7, 5]],
  ] as const) {
    ctx.lineWidth = width;
    ctx.strokeStyle = colour;
    ctx.setLineDash([...dash]);
    ctx.stroke();
  }
  ctx.setLineDash([]);
};

OVERLAYS[STYLE] = paintTruePath;

const GRAPH = "slam";
const PATH = "true_path";
const DRIFT = FAULTS.find((fault) => fault.name === "drift");

/** The number of loops of a graph; edges of odometry have no value. */
const loopsOf = (content: LayerContent | null): number =>
  content?.values?.reduce((sum, value) => sum + (Number.isNaN(value) ? 0 : 1), 0) ?? 0;

export function SlamGroup({ store }: { readonly store: Store }) {
  const faults = store.faults.value ?? {};
  const [drifts, corrects] = [faults.drift === true, faults.drift === true && faults.slam === true];
  const isSonar = store.sensor.values.value.kind === "sonar_ring";
  useEffect(() => {
    if (!corrects) return;
    const ends = [GRAPH, PATH].map((name) => store.layers.subscribe(name));
    return () => {
      for (const end of ends) end();
    };
  }, [store, corrects]);
  if (!DRIFT) return null;
  const turn = (drift: boolean, slam: boolean): void => void turnFault(store, DRIFT, drift, { slam });
  return (
    <div class="slam-group">
      <p class="quiet">
        Worn wheels report a drifting path. SLAM matches each scan with those before it, and corrects the whole path
        where the robot comes back to a place.
      </p>
      <Toggle
        label="Drifting wheels"
        sentence="Make the map with the poses that the wheels report."
        checked={drifts}
        onChange={(wanted) => turn(wanted, wanted && corrects)}
      />
      <Toggle
        label="SLAM while driving"
        sentence={isSonar ? "Sonar readings are too wide to be matched." : "Correct these poses as the robot drives."}
        checked={corrects}
        disabled={isSonar}
        onChange={(wanted) => turn(wanted || drifts, wanted)}
      />
      {drifts && <Readout store={store} corrects={corrects} />}
    </div>
  );
}

function Readout({ store, corrects }: { readonly store: Store; readonly corrects: boolean }) {
  const frame = store.frame.value;
  const graph = store.layers.content(GRAPH).value;
  const believed = frame?.believed_pose;
  const off = frame && believed ? Math.hypot(frame.pose[0] - believed[0], frame.pose[1] - believed[1]) : 0;
  return (
    <>
      <dl class="facts-list">
        <dt>The believed pose is off by</dt>
        <dd class="slam-off">{off < 1 ? `${written(100 * off, 0)} cm` : `${written(off, 1)} m`}</dd>
        {corrects && graph && (
          <>
            <dt>Scans matched</dt>
            <dd>{graph.columns[0]?.length ?? 0}</dd>
            <dt>Loops closed</dt>
            <dd>{loopsOf(graph)}</dd>
          </>
        )}
      </dl>
      {corrects && (
        <p class="quiet legend">
          <span>
            <span class="slam-line believed" /> believed path
          </span>
          <span>
            <span class="slam-line loop" /> loops
          </span>
          <span>
            <span class="slam-line true" /> true path
          </span>
        </p>
      )}
    </>
  );
}
