/** The views of the lab's stage; at first the true world and the robot's map. */

import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { between } from "../../grid/poses";
import type { Picture } from "../../render/picture/Picture";
import type { Store } from "../../store/store";
import { CompareOverlay } from "../../tools/compare/CompareOverlay";
import type { Comparison } from "../../tools/compare/comparison";
import { secondMapNames } from "../../tools/compare/SecondMap";
import { ToolHint } from "../../tools/editing/Toolbar";
import { Measuring, MeasuringButtons } from "../../tools/measure/MapTools";
import { BeliefView } from "../../tools/picture/BeliefView";
import { ComputingMap } from "../../tools/picture/ComputingMap";
import { Plate } from "../../tools/picture/Plate";
import { WorldView } from "../../tools/picture/WorldView";
import { PlacingHint, RobotAnnouncement } from "../../tools/placing/Placing";
import { Readout } from "../../tools/readout/Readout";
import { Button } from "../../ui/Button";
import { kept } from "../../ui/browser/kept";
import { lazy } from "../../ui/lazy";
import { written } from "../../ui/numbers";
import type { Preset } from "../../ui/stage/LayoutChoice";
import { type Layout, layoutOf } from "../../ui/stage/layout";
import type { StageView } from "../../ui/stage/Stage";
import { addressOf } from "../../wire/ask";
import type { Pose } from "../../wire/protocol";
import type { Live } from "../classSession";

const metres = (value: number): string => written(value, 2);
const degrees = (value: number): string => written((value * 180) / Math.PI, 1);

function LabFrames({ store }: { readonly store: Store }) {
  const frame = store.frame.value;
  if (!frame) return null;
  const { pose, believed_pose, sensor_pose } = frame;
  const rows: readonly (readonly [child: string, parent: string, whose: string, pose: Pose])[] = [
    ["base_link", "map", "as the robot believes", believed_pose ?? pose],
    ["base_link", "map", "true", pose],
    ["laser", "base_link", "its mount", between(pose, sensor_pose)],
  ];
  return (
    // biome-ignore lint/a11y/noNoninteractiveTabindex: it scrolls, which the keyboard can only do with the focus in it
    <div class="lab-frames" tabIndex={0}>
      <table>
        <caption class="quiet">
          Each transform now. The wheels’ drift, if it is on, is in the pose that is believed.
        </caption>
        <thead>
          <tr>
            <th scope="col">frame</th>
            <th scope="col">x (m)</th>
            <th scope="col">y (m)</th>
            <th scope="col">yaw (°)</th>
          </tr>
        </thead>
        <tbody>
          {rows.map(([child, parent, whose, [x, y, yaw]]) => (
            <tr key={whose}>
              <th scope="row">
                {child}{" "}
                <span class="quiet">
                  in {parent}, {whose}
                </span>
              </th>
              <td class="number">{metres(x)}</td>
              <td class="number">{metres(y)}</td>
              <td class="number">{degrees(yaw)}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

interface CameraProps {
  readonly store: Store;
  readonly session: string;
}

export function Camera({ store, session }: CameraProps) {
  const map3d = store.part("map3d");
  const now = map3d.message.value;
  if (!now?.is_on || now.values.sensor !== "depth_camera") {
    return (
      <div class="lab-second">
        <p>What a depth camera on the robot sees. Its images also make the 3D map.</p>
        <Button
          onClick={() => {
            map3d.isEnded.value = false;
            store.setPart("map3d", { sensor: "depth_camera" });
          }}
        >
          Give the robot a depth camera
        </Button>
      </div>
    );
  }
  return (
    <figure class="lab-camera">
      {now.taken > 0 && <DepthImage session={session} taken={now.taken} />}
      <figcaption class="quiet">
        White is 0 m, dark grey {written(Number(now.values.reach), 1)} m; black returned nothing.
      </figcaption>
    </figure>
  );
}

/** The newest image, after `number` images. The next is requested when the last has arrived. */
export function DepthImage({ session, taken }: { readonly session: string; readonly taken: number }) {
  const shown = useSignal(taken);
  const isAwaited = useRef(true);
  const next = (isEnded: boolean): void => {
    if (isEnded) isAwaited.current = false;
    if (isAwaited.current || shown.peek() === taken) return;
    isAwaited.current = true;
    shown.value = taken;
  };
  useEffect(() => next(false), [taken]);
  const address = addressOf("GET /api/sessions/{session_id}/depth.png", { session_id: session });
  return (
    <img
      src={`${address}?${shown.value}`}
      alt="Depth image: the nearer the lighter"
      onLoad={() => next(true)}
      onError={() => next(true)}
    />
  );
}

const Scene = lazy(async () => (await import("../../tools/scene/Scene")).Scene);
const LabPlots = lazy(async () => (await import("./plots/LabPlots")).LabPlots);
const CorrectMap = lazy(async () => (await import("./CorrectMap")).CorrectMap);

export interface LabPictures {
  readonly session: Live | null;
  /** What the pictures show: the session's store, or a recording before there is a session. */
  readonly shown: Store | null;
  readonly comparison: Comparison | null;
  /** Called with the picture of the map. */
  readonly onPicture: (picture: Picture) => void;
}

interface View {
  readonly kind: string;
  readonly title: string;
  readonly content: (pictures: LabPictures, head: ComponentChildren) => ComponentChildren;
}

/** In the order in which they fill a layout. */
const VIEWS: readonly View[] = [
  { kind: "world", title: "The world", content: (pictures, head) => <World {...pictures} head={head} /> },
  { kind: "map", title: "The belief", content: (pictures, head) => <Belief {...pictures} head={head} /> },
  {
    kind: "3d",
    title: "3D",
    content: ({ session }, head) => (
      <Plate title="3D" head={head}>
        {session && (
          <div class="lab-scene">
            <Scene store={session.store} session={session.id} />
          </div>
        )}
      </Plate>
    ),
  },
  {
    kind: "second",
    title: "Second map",
    content: ({ session, comparison }, head) => (
      <Plate title="Second map" head={head}>
        {session && comparison && <CorrectMap store={session.store} comparison={comparison} />}
      </Plate>
    ),
  },
  {
    kind: "picture",
    title: "Camera",
    content: ({ session }, head) => (
      <Plate title="Camera" head={head}>
        {session && <Camera store={session.store} session={session.id} />}
      </Plate>
    ),
  },
  {
    kind: "plots",
    title: "Plots",
    content: ({ session }, head) => (
      <Plate title="Plots" head={head}>
        {session && <LabPlots store={session.store} />}
      </Plate>
    ),
  },
  {
    kind: "frames",
    title: "Frames",
    content: ({ session }, head) => (
      <Plate title="Frames" head={head}>
        {session && <LabFrames store={session.store} />}
      </Plate>
    ),
  },
];

export const KINDS: readonly string[] = VIEWS.map(({ kind }) => kind);

/** The default layout. */
export const WORLD_AND_MAP: Layout = layoutOf("beside", ["world", "map"]);

export const PRESETS: readonly Preset[] = [
  ["World and belief", WORLD_AND_MAP],
  ["Belief", layoutOf("one", ["map"])],
  ["Belief and 3D", layoutOf("beside", ["map", "3d"])],
  ["Belief and plots", layoutOf("beside", ["map", "plots"])],
  ["Two maps", layoutOf("beside", ["map", "second"])],
  ["Four views", layoutOf("four", KINDS.slice(0, 4))],
];

/** The layout that this browser used last, as text. */
export const lastLayout = kept("gridbloom.lab.views", "", (value): value is string => typeof value === "string");

/** The views for the stage. */
export const viewsOf = (pictures: LabPictures): readonly StageView[] =>
  VIEWS.map(({ kind, title, content }) => ({
    kind,
    title,
    hasOwnHead: true,
    content: (head) => content(pictures, head),
  }));

interface PictureProps extends LabPictures {
  readonly head: ComponentChildren;
}

function World({ session, shown, head }: PictureProps) {
  const store = session?.store ?? null;
  return (
    <Plate
      title="The world"
      note="ground truth"
      head={head}
      actions={
        <Button
          kind="quiet"
          icon="fit"
          label="Show everything"
          onClick={() => {
            if (store) store.viewHeld.value = false;
          }}
        />
      }
      caption={
        store && (
          <>
            <PlacingHint store={store} />
            <ToolHint store={store} />
            <RobotAnnouncement store={store} />
          </>
        )
      }
    >
      {shown && <WorldView store={shown} />}
    </Plate>
  );
}

function Belief({ session, shown, comparison, onPicture, head }: PictureProps) {
  const store = session?.store ?? null;
  return (
    <Plate
      title="The belief"
      note="the map of the robot"
      head={head}
      actions={store && <MeasuringButtons store={store} />}
      caption={store ? <Readout store={store} /> : null}
    >
      {shown && (shown !== store || comparison) && (
        <BeliefView store={shown} {...(shown === store && comparison && { comparison })} onPicture={onPicture} />
      )}
      {store && comparison && (
        <>
          {store.compared.value && (
            <CompareOverlay comparison={comparison} names={secondMapNames(store.compared.value)} refused={null} />
          )}
          <Measuring store={store} />
          <ComputingMap store={store} />
        </>
      )}
    </Plate>
  );
}
