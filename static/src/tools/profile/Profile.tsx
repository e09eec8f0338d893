import { batch, effect, type ReadonlySignal, type Signal, useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useLayoutEffect, useMemo, useRef } from "preact/hooks";
import { probability } from "../../grid/cellValues";
import {
  beamModel,
  cellIndexAt,
  halfWindow,
  hitCells,
  isCone,
  type SensorModelParameters,
} from "../../grid/sensorModel";
import { ticks, toPixel, toValue } from "../../render/chart/scale";
import { Button } from "../../ui/Button";
import { useDrawing } from "../../ui/browser/useDrawing";
import { zoomOf } from "../../ui/browser/useSize";
import { Handle } from "../../ui/Handle";
import { lazy } from "../../ui/lazy";
import { signed, written } from "../../ui/numbers";
import { Curve } from "./Curve";
import { type Controls, controlsFor } from "./controls";
import { tableBounds } from "./handles";
import { cellText, Strip } from "./Strip";
import { RangeMaxFlag } from "./sharedHandles";
import { ProfileView } from "./view";
import "./profile.css";

/** The piecewise formula with the current numbers. */
export function Formula({ view }: { view: ProfileView }) {
  const values = view.values.value;
  const model = beamModel(values);
  const z = view.z.value;
  const certain = values.model === "moravec_elfes";
  if (view.noReturn.value) {
    return (
      <math class="formula" display="block">
        <mrow>
          <mi>{certain ? "certainty" : "Δℓ"}</mi>
          <mo>=</mo>
          {values.no_return === "free" ? (
            <mrow>
              <mrow class="noun-miss">
                <mtext>{certain ? "empty: (1 − (r/max range)²) · (1 − (2φ/β)²)" : signed(model.miss)}</mtext>
              </mrow>
              <mtext>&nbsp; for r ≤ max range = {written(values.range_max, 1)} m</mtext>
            </mrow>
          ) : (
            <mn>0</mn>
          )}
        </mrow>
      </math>
    );
  }
  const rows = rowsOf(values, z);
  const isLong = rows.some(({ value }) => value.length > SHORT);
  return (
    <math class={`formula${isLong ? " long" : ""}`} display="block">
      <mrow>
        <mi>{certain ? "certainty" : "Δℓ"}</mi>
        <mrow>
          <mo>(</mo>
          <mi>{isCone(values) ? "r, φ" : "r"}</mi>
          <mo>)</mo>
        </mrow>
        <mo>=</mo>
        <mrow>
          <mo>&#123;</mo>
          <mtable>
            {rows.map(({ noun, value, where }) => (
              <mtr key={noun}>
                <mtd>
                  <mrow class={noun}>
                    <mtext>{value}</mtext>
                  </mrow>
                </mtd>
                <mtd>
                  <mtext>{where}</mtext>
                </mtd>
              </mtr>
            ))}
          </mtable>
        </mrow>
      </mrow>
    </math>
  );
}

/** Greatest length of a value that fits next to its condition on a phone, characters. */
const SHORT = 8;

interface Row {
  readonly noun: string;
  readonly value: string;
  readonly where: string;
}

/** The increment of a reading in each zone, and the extent of the zone. */
function rowsOf(values: SensorModelParameters, z: number): readonly Row[] {
  const model = beamModel(values);
  const half = halfWindow(z, values);
  const [miss, hit] = [signed(model.miss), signed(model.hit)];
  const before = half > 0 ? `r < z − w/2 = ${written(z - half, 2)} m` : `r < z = ${written(z, 2)} m`;
  const within = half > 0 ? `|r − z| ≤ w/2 = ${written(half, 3)} m` : "the cell that holds z";
  const row = (noun: string, value: string, where: string): Row => ({ noun: `noun-${noun}`, value, where });
  const beyond = row("prior", "0", isCone(values) ? "beyond, and outside β" : "beyond");
  switch (values.model) {
    case "step_window":
      return [
        row("miss", `logit ${written(values.p_free, 2)} − ℓ₀ = ${miss}`, before),
        row("hit", `logit ${written(values.p_occ, 2)} − ℓ₀ = ${hit}`, within),
        beyond,
      ];
    case "smooth_ramp":
      return [
        row("miss", miss, `r < z − 2σ = ${written(z - half, 2)} m, σ = ${written(half / 2, 3)} m`),
        row("hit", `${miss} → ${hit} → 0`, `up to z, down to z + 2σ = ${written(z + half, 2)} m`),
        beyond,
      ];
    case "hit_counting":
      return [
        row("miss", `ln n₀(1−p₀) − ln (1 + n₀(1−p₀)) = ${miss}`, `first visit: ${before}`),
        row("hit", `ln (1 + n₀p₀) − ln n₀p₀ = ${hit}`, `first visit: ${within}`),
        row("prior", "p = (hits + n₀p₀) / (hits + misses + n₀)", "after all visits"),
      ];
    case "sonar_cone": {
      const fades = values.cone_profile === "gaussian";
      return [
        row("miss", fades ? `${miss} · (1 − (r/(z−w/2))²) · exp(−8(φ/β)²)` : miss, before),
        row("hit", fades ? `${hit} · (1 − ((r−z)/(w/2))²) · exp(−8(φ/β)²)` : hit, within),
        beyond,
      ];
    }
    case "moravec_elfes":
      return [
        row("miss", "empty: (1 − (r/(z−w/2))²) · (1 − (2φ/β)²)", before),
        row("hit", "occupied: (1 − ((r−z)/(w/2))²) · (1 − (2φ/β)²)", within),
        beyond,
      ];
    default:
      return [row("miss", miss, before), row("hit", hit, within), beyond];
  }
}

const many = (count: number): string => (count === 1 ? "1 cell" : `${count} cells`);

/** The formula in words. */
function InWords({ view }: { view: ProfileView }) {
  const values = view.values.value;
  const model = beamModel(values);
  const prior = values.log_odds_prior;
  const inWindow = hitCells(view.z.value, values);
  const p = (evidence: number): string => written(probability(prior + evidence), 2);
  if (!inWindow) {
    return values.no_return === "free" ? (
      <p>
        There was <b class="noun-beam">no return</b> within {written(values.range_max, 1)} m. With the setting “no
        return: free”,{" "}
        {isCone(values) ? "all cells of the cone" : `all ${cellIndexAt(values.range_max, values.resolution) + 1} cells`}{" "}
        up to the max range count as <b class="noun-miss">passed</b>
        {values.model === "moravec_elfes"
          ? ", with the greatest certainty near the sensor and on the axis."
          : ` and get ${signed(model.miss)}.`}
      </p>
    ) : (
      <p>
        There was <b class="noun-beam">no return</b> within {written(values.range_max, 1)} m. With the setting “no
        return: ignore”, this beam does not change the map.
      </p>
    );
  }
  const hits = inWindow[1] - inWindow[0] + 1;
  if (values.model === "moravec_elfes") {
    return (
      <p>
        The echo came from <b class="noun-beam">z = {written(view.z.value, 2)} m</b>, from anywhere on the arc. Closer
        than that, the cone is <b class="noun-miss">probably empty</b>, with the greatest certainty near the sensor and
        on the axis. On the arc <b class="noun-hit">there is an obstacle</b>: cells known to be empty are excluded, the
        others share a total certainty of 1. The certainties are combined by the rules of 1985; no log-odds are added.
      </p>
    );
  }
  if (values.model === "sonar_cone") {
    return (
      <p>
        The echo came from <b class="noun-beam">z = {written(view.z.value, 2)} m</b>, from anywhere on the arc: every
        cell on it gets{" "}
        <b class="noun-hit">
          {values.cone_profile === "gaussian" && "at most "}
          {signed(model.hit)}
        </b>
        , as if there were an obstacle in each. Every cell closer gets{" "}
        <b class="noun-miss">
          {values.cone_profile === "gaussian" && "at most "}
          {signed(model.miss)}
        </b>
        . Only other readings can say where on the arc it is.
      </p>
    );
  }
  return (
    <p>
      The reading is <b class="noun-beam">z = {written(view.z.value, 2)} m</b>. The beam{" "}
      <b class="noun-miss">passed {many(inWindow[0])}</b>: an unseen cell drops from {p(0)} to {p(model.miss)}.
      {values.model === "smooth_ramp" ? (
        <>
          {" "}
          In the {many(hits)} around its end the evidence changes from free to <b class="noun-hit">occupied</b>, up to p{" "}
          {p(model.hit)} where it ended, and then decreases to 0.
        </>
      ) : (
        <>
          {" "}
          It <b class="noun-hit">ended in {hits === 1 ? "1 cell" : `the window, ${hits} cells`}</b>: an unseen cell
          rises to {p(model.hit)}.
        </>
      )}{" "}
      It says nothing about the cells <b class="noun-prior">behind</b>.
    </p>
  );
}

/** The whole beam, to scale: the sensor, the reading, the max range, and the part that is enlarged below. */
export function Beam({ view, controls }: { view: ProfileView; controls: Controls }) {
  const { beam, curve } = view.layout.value;
  const scale = view.beamScale.value;
  const values = view.values.value;
  const z = view.z.value;
  const noReturn = view.noReturn.value;
  const { low: start, high } = view.xScale.value;
  const span = high - start;
  const x = (s: number): number => toPixel(s, scale);
  const middle = (beam.top + beam.bottom) / 2;
  const end = noReturn ? values.range_max : z;
  const half = halfWindow(noReturn ? values.range_max : z, values);
  const freeTo = noReturn ? (values.no_return === "free" ? values.range_max : 0) : Math.max(0, z - half);
  const handleX = Math.min(x(noReturn ? Math.min(z, view.total.value) : z), beam.right);
  const rangeX = Math.min(x(values.range_max), beam.right);
  const lensLeft = x(start);
  const lensRight = Math.max(x(start + span), lensLeft + 3);
  const labelEnd = rangeX > view.width.value - 132;

  return (
    <g>
      <polygon
        class="lens-cone"
        points={`${lensLeft},${beam.bottom - 4} ${lensRight},${beam.bottom - 4} ${curve.right},${curve.top - 12} ${curve.left},${curve.top - 12}`}
      />
      <line class="beam-axis" x1={beam.left} x2={beam.right} y1={middle} y2={middle} />
      <line class="beam-line" x1={beam.left} x2={x(Math.min(end, view.total.value))} y1={middle} y2={middle} />
      {freeTo > 0 && <rect class="fill-miss" x={beam.left} y={middle - 5} width={x(freeTo) - beam.left} height={10} />}
      {!noReturn && (
        <rect
          class="fill-hit"
          x={x(Math.max(0, z - half)) - 1}
          y={middle - 9}
          width={Math.max(3, x(z + half) - x(Math.max(0, z - half)))}
          height={18}
        />
      )}
      <rect
        class="lens-frame"
        x={lensLeft}
        y={beam.top - 2}
        width={lensRight - lensLeft}
        height={beam.bottom - beam.top}
        rx={3}
      />
      <path
        class="robot"
        d={`M${beam.left - 16} ${middle - 9}L${beam.left} ${middle}L${beam.left - 16} ${middle + 9}Z`}
      />
      {ticks(0, view.total.value, view.width.value < 560 ? 4 : 8).map((tick) => (
        <g key={tick} class="tick">
          <line x1={x(tick)} x2={x(tick)} y1={beam.bottom} y2={beam.bottom + 4} />
          <text x={x(tick)} y={beam.bottom + 16} text-anchor="middle">
            {`${written(tick, tick % 1 === 0 ? 0 : 1)}${tick === 0 ? " m" : ""}`}
          </text>
        </g>
      ))}
      <text class="axis-title" x={beam.left - 16} y={beam.top - 5}>
        {view.width.value < 430 ? "beam" : "the whole beam"}
      </text>
      <RangeMaxFlag
        view={view}
        controls={controls}
        on="beam"
        x={rangeX}
        y={beam.top - 18}
        down={beam.bottom}
        label={labelEnd ? { x: rangeX - 12, anchor: "end" } : { x: rangeX + 12, anchor: "start" }}
      />
      <Handle
        label="Measured range z, on the whole beam"
        sentence="Moves the reading along the whole beam; the enlarged part follows."
        axis="x"
        tone="tone-beam"
        now={noReturn ? values.range_max : z}
        low={0}
        high={view.total.value}
        text={noReturn ? "no return" : `${written(z, 2)} metres`}
        grab={{ x: handleX - 22, y: middle - 8, width: 44, height: 40 }}
        {...controls.reading("beam")}
      >
        <circle class="handle-mark" cx={handleX} cy={middle} r={8} />
      </Handle>
    </g>
  );
}

const Cone = lazy(async () => (await import("./Cone")).Cone);
const ConeCells = lazy(async () => (await import("./Cone")).ConeCells);

interface ProfileProps {
  /** The current values, by the names of the mapper's table. */
  readonly parameters: ReadonlySignal<Readonly<Record<string, unknown>>>;
  readonly setParameter: (name: string, value: number) => void;
  /** Range of the inspected beam, metres; null for no return, undefined if there is no beam. */
  readonly reading: ReadonlySignal<number | null | undefined>;
  /** The direction of its beam or cone in the legend: "straight ahead". */
  readonly where: string;
  /** The reading set by dragging, metres, if other figures show it too; null while the figure follows the beam. */
  readonly grabbed?: Signal<number | null>;
}

/**
 * The inverse sensor model along one beam: a curve that can be dragged, the cells below it, its formula with numbers.
 * It is updated in the browser at once; the map follows from the server.
 */
export function Profile({ parameters, setParameter, reading, where, grabbed }: ProfileProps) {
  const view = useProfileView(parameters, reading, grabbed);
  return (
    <ProfileFigure view={view} setParameter={setParameter} where={where}>
      <figcaption>
        <ProfileText view={view} />
      </figcaption>
    </ProfileFigure>
  );
}

/** The state of a profile, for its figure and its text. */
export function useProfileView(
  parameters: ProfileProps["parameters"],
  reading: ProfileProps["reading"],
  grabbed?: ProfileProps["grabbed"],
): ProfileView {
  const view = useMemo(() => new ProfileView(parameters, reading, grabbed), [parameters, reading, grabbed]);
  useEffect(() => () => view.dispose(), [view]);
  return view;
}

/** The formula of a profile with its numbers, and in words. */
export function ProfileText({ view }: { readonly view: ProfileView }) {
  return (
    <div class="profile-caption">
      <Formula view={view} />
      <InWords view={view} />
    </div>
  );
}

interface ProfileFigureProps {
  readonly view: ProfileView;
  readonly setParameter: ProfileProps["setParameter"];
  readonly where: string;
  /** Whether it fills the height of its container, instead of having its natural height; it then has a title. */
  readonly fits?: boolean;
  readonly children?: ComponentChildren;
}

/** The figure of a profile, and the content below it. */
export function ProfileFigure({ view, setParameter, where, fits = false, children }: ProfileFigureProps) {
  const { reading } = view;
  const controls = useMemo(() => {
    return controlsFor(view, tableBounds, setParameter);
  }, [view, setParameter]);
  const frame = useRef<HTMLDivElement>(null);
  const measured = useDrawing(frame, 720);
  useLayoutEffect(
    () =>
      effect(() => {
        const { width, height } = measured.value;
        batch(() => {
          view.width.value = Math.max(280, width);
          view.height.value = fits ? height : null;
        });
      }),
    [view, measured, fits],
  );

  const { width, height, curve, strip } = view.layout.value;
  const { scale } = measured.value;
  const hover = (event: PointerEvent): void => {
    // The frame's position is not read while a handle is dragged, which would force a layout in every frame.
    const box = view.held.peek() === null && frame.current?.getBoundingClientRect();
    if (!box) return;
    const zoom = zoomOf(event.currentTarget as Element);
    const px = (event.clientX - box.left) / zoom;
    const py = (event.clientY - box.top) / zoom;
    const inside = px >= curve.left && px <= curve.right && py >= curve.top && py <= strip.bottom + 10;
    view.hovered.value = inside ? cellIndexAt(toValue(px, view.xScale.peek()), view.values.peek().resolution) : null;
  };
  const hovered = view.hovered.value;
  const cone = isCone(view.values.value);
  const followed = cone ? "the cone" : "the beam";
  const following = view.grabbed.value === null;
  const isHeld = view.held.value !== null;
  const wasHeld = useSignal(false);
  useEffect(() => {
    if (isHeld) wasHeld.value = true;
  }, [isHeld]);

  return (
    <figure class={`profile${fits ? " fits" : ""}`} aria-label="Inverse sensor model along one beam">
      <div class="profile-bar">
        {fits && <h2>The sensor model</h2>}
        <span class="profile-source">
          {following ? (
            reading.value === undefined ? (
              "An example reading: drag it"
            ) : (
              <>
                <span class="live-dot" />{" "}
                {view.hasPointer.value ? "paused while the pointer is here" : `following ${followed} ${where}`}
              </>
            )
          ) : (
            "reading set by hand"
          )}
        </span>
        {!following && reading.value !== undefined && (
          <Button
            kind="quiet"
            icon="target"
            onClick={() => {
              view.grabbed.value = null;
            }}
          >
            Follow {followed}
          </Button>
        )}
        <output class="profile-readout" aria-live="off">
          {hovered === null || cone ? null : cellText(hovered, view)}
        </output>
        {fits && !wasHeld.value && (hovered === null || cone) && (
          <span class="profile-hint">
            Drag the coloured handles<span class="profile-effect">: the map follows</span>.
          </span>
        )}
      </div>
      <div class="profile-frame" ref={frame} {...(fits ? {} : { style: { height: `${scale * height}px` } })}>
        {cone && <ConeCells view={view} scale={scale} />}
        <svg
          class="profile-svg drawing"
          style={{ zoom: scale }}
          role="presentation"
          width={width}
          height={height}
          viewBox={`0 0 ${width} ${height}`}
          onPointerMove={hover}
          onPointerDown={hover}
          onPointerEnter={() => view.setPointer(true)}
          onPointerLeave={() => {
            view.setPointer(false);
            view.hovered.value = null;
          }}
        >
          <Beam view={view} controls={controls} />
          {cone ? (
            <Cone view={view} controls={controls} />
          ) : (
            <>
              <Strip view={view} />
              <Curve view={view} controls={controls} />
            </>
          )}
        </svg>
      </div>
      {children}
    </figure>
  );
}
