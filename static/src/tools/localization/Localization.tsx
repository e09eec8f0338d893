/** Localizing the robot in the plan of its world: starting, kidnapping, and failures. */

import { computed, type ReadonlySignal, useSignal, useSignalEffect } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { linePath, ticks } from "../../render/chart/scale";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { useDrawing } from "../../ui/browser/useDrawing";
import { SwitchChip } from "../../ui/dock/SwitchChip";
import { Disclosure } from "../../ui/Panel";
import { ask } from "../../wire/ask";
import type { LocalizationMessage, Parameter, Values } from "../../wire/protocol";
import { ParameterRows } from "../parameters/ParameterRows";
import { AmclYaml } from "./AmclYaml";
import { MotionFan } from "./MotionFan";
import {
  type Given,
  grown,
  isOn as isTurnedOn,
  LIKELIHOOD_FIELD,
  PARTICLES,
  type Point,
  SETTINGS,
  type Setting,
  turned,
} from "./model";
import { SensorCurve } from "./SensorCurve";
import { filterOf } from "./state";
import "./localization.css";

const HEIGHT = 150;
const LEFT = 46;
const RIGHT = 46;
const TOP = 16;
const BOTTOM = HEIGHT - 36;
const TICK_PX = 90;

/** The error of the estimate and the entropy of the particles over the used scans. */
function ErrorChart({ points }: { readonly points: readonly Point[] }) {
  const box = useRef<HTMLDivElement>(null);
  const { width, scale } = useDrawing(box, 420).value;
  const right = width - RIGHT;
  const first = points[0]?.updates ?? 0;
  const last = Math.max(points.at(-1)?.updates ?? 0, first + 20);
  const metres = Math.max(1, ...points.map(({ error }) => error));
  const bits = Math.max(4, ...points.map(({ entropy }) => entropy));
  const x = (updates: number): number => LEFT + ((updates - first) / (last - first)) * (right - LEFT);
  const y = (share: number): number => BOTTOM - share * (BOTTOM - TOP);
  const path = (share: (point: Point) => number): string =>
    linePath(points.map((point) => [x(point.updates), y(share(point))]));
  return (
    <div class="localization-chart" ref={box} style={{ height: `${scale * HEIGHT}px` }}>
      <svg
        class="drawing"
        style={{ zoom: scale }}
        width={width}
        height={HEIGHT}
        role="img"
        aria-label="Error of the estimate and entropy of the particles, over the scans that were used"
      >
        <line class="axis" x1={LEFT} x2={right} y1={BOTTOM} y2={BOTTOM} />
        <text x={LEFT - 6} y={TOP + 4} text-anchor="end">
          {metres.toFixed(metres < 10 ? 1 : 0)} m
        </text>
        <text x={LEFT - 6} y={BOTTOM + 4} text-anchor="end">
          0
        </text>
        <text x={right + 6} y={TOP + 4}>
          {bits.toFixed(0)} bit
        </text>
        {ticks(first, last, width / TICK_PX).map((tick) => (
          <text key={tick} x={x(tick)} y={BOTTOM + 16} text-anchor="middle">
            {tick}
          </text>
        ))}
        <text x={(LEFT + right) / 2} y={HEIGHT - 4} text-anchor="middle">
          scans used
        </text>
        <path class="entropy" d={path((point) => point.entropy / bits)} />
        <path class="error" d={path((point) => point.error / metres)} />
      </svg>
    </div>
  );
}

interface ModelsProps {
  readonly table: readonly Parameter[];
  /** Those that differ from the defaults. */
  readonly values: ReadonlySignal<Values>;
  /** The sensor's longest range, m. */
  readonly range_max: number;
  readonly set: (values: Values) => void;
}

const of = (table: readonly Parameter[], group: string): readonly Parameter[] =>
  table.filter((row) => row.group === group);

function FilterModels({ table, values, range_max, set }: ModelsProps) {
  const all = useMemo(
    () =>
      computed(
        (): Values => ({
          ...Object.fromEntries(table.map((row) => [row.name, row.initial])),
          ...values.value,
        }),
      ),
    [table, values],
  );
  const setOne = useMemo(() => (name: string, value: Values[string]) => set({ [name]: value }), [set]);
  const sensor = of(table, "sensor");
  const model = sensor.filter((row) => row.name === "laser_model_type");
  const numbers = sensor.filter((row) => row.name !== "laser_model_type");
  const now = all.value;
  if (table.length === 0) return null;
  return (
    <>
      <Disclosure title="Sensor model">
        <ParameterRows rows={model} values={all} set={setOne} />
        <SensorCurve values={now} rows={sensor} range_max={range_max} set={set} />
        <ParameterRows rows={numbers} values={all} set={setOne} />
      </Disclosure>
      <Disclosure title="Motion model">
        <MotionFan values={now} />
        <ParameterRows rows={of(table, "motion")} values={all} set={setOne} />
      </Disclosure>
    </>
  );
}

const LONGEST = 12;

export function Localization({ store }: { readonly store: Store }) {
  const message = store.part("localization").message.value;
  const isOn = message?.is_on === true;
  const points = useSignal<readonly Point[]>([]);
  const table = useSignal<readonly Parameter[]>([]);
  useSignalEffect(() => {
    const news = store.part("localization").message.value;
    points.value = news ? grown(points.peek(), news) : [];
  });
  useEffect(() => (isOn ? store.layers.subscribe(PARTICLES) : undefined), [store, isOn]);
  useEffect(() => {
    ask("GET /api/localization/parameters", {}).then(
      (answer) => {
        table.value = answer.table;
      },
      () => undefined, // the server does not answer, so the figures are left out
    );
  }, [table]);
  const showsField = store.underlay.value === LIKELIHOOD_FIELD;
  useEffect(() => {
    if (!isOn && store.underlay.peek() === LIKELIHOOD_FIELD) store.underlay.value = null;
    return isOn && showsField ? store.layers.subscribe(LIKELIHOOD_FIELD) : undefined;
  }, [store, isOn, showsField]);
  const given: Given = {
    values: filterOf(store).values.value,
    map: filterOf(store).map.value,
    world: store.world.value?.name,
  };
  const begin = (values: Values, map: string): void => {
    points.value = [];
    filterOf(store).begin(values, map);
  };
  const turn = (setting: Setting): void => {
    const next = turned(setting, given, store.world.peek()?.names[0] ?? "");
    if (next.world !== undefined && next.world !== given.world) store.chooseWorld(next.world);
    begin(next.values, next.map);
  };
  const set = useMemo(() => (values: Values) => filterOf(store).set(values), [store]);
  const on = SETTINGS.filter((setting) => isTurnedOn(setting, given));
  return (
    <div class="localization">
      <p class="localization-note">
        A particle filter gets the plan of the world as it is now, the wheels’ odometry and the scans. It has to find
        out where the robot is.
      </p>
      <div class="localization-row">
        <Button kind="primary" onClick={() => begin(given.values, given.map)}>
          {isOn ? "Start again, anywhere" : "Find the robot"}
        </Button>
        {isOn && (
          <Button kind="quiet" onClick={() => store.send({ type: "localize", value: false })}>
            End
          </Button>
        )}
      </div>
      <fieldset class="localization-row">
        <legend>What goes wrong</legend>
        {SETTINGS.map((setting) => (
          <SwitchChip
            key={setting.name}
            label={setting.label}
            title={setting.look}
            checked={on.includes(setting)}
            onChange={() => turn(setting)}
          />
        ))}
      </fieldset>
      {isOn && message && (
        <>
          <Outcome message={message} />
          <ErrorChart points={points.value} />
          <p class="localization-key">
            <span class="key error" aria-hidden="true" /> error <span class="key entropy" aria-hidden="true" /> entropy
          </p>
          <p class="localization-note">
            <b>Kidnap the robot:</b> click somewhere else in the world. The filter is not told.
          </p>
        </>
      )}
      {isOn && (
        <SwitchChip
          label="Likelihood field under the particles"
          checked={showsField}
          onChange={(wanted) => {
            store.underlay.value = wanted ? LIKELIHOOD_FIELD : null;
          }}
        />
      )}
      <FilterModels
        table={table.value}
        values={filterOf(store).values}
        range_max={Number(store.sensor.values.value.range_max ?? LONGEST)}
        set={set}
      />
      <AmclYaml values={() => filterOf(store).values.peek()} onOpen={(values) => begin(values, given.map)} />
      <div class="localization-note" role="status">
        {on.map(({ name, look }) => (
          <p key={name}>
            <b>Look for:</b> {look}
          </p>
        ))}
      </div>
    </div>
  );
}

function Outcome({ message }: { readonly message: LocalizationMessage }) {
  const off = message.error_m ?? 0;
  const { is_converged, is_sure } = message;
  const found = off < 1 ? "Found" : "Wrong";
  const certainty = is_sure === off < 1 ? "" : is_sure ? ", and sure of it" : ", not sure";
  const verdict = is_converged ? found + certainty : "Not found yet";
  return (
    <dl class="number-row">
      <div>
        <dt>State</dt>
        <dd>{verdict}</dd>
      </div>
      <div>
        <dt>Error</dt>
        <dd>{off.toFixed(2)} m</dd>
      </div>
      <div>
        <dt>Particles</dt>
        <dd>{message.n_particles.toLocaleString("en")}</dd>
      </div>
      <div>
        <dt>Entropy</dt>
        <dd>{message.entropy.toFixed(1)} bit</dd>
      </div>
    </dl>
  );
}
