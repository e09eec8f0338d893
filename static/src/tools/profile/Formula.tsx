import { probability } from "../../grid/cellValues";
import {
  beamModel,
  cellIndexAt,
  halfWindow,
  hitCells,
  isCone,
  type SensorModelParameters,
} from "../../grid/sensorModel";
import { signed, written } from "../../ui/numbers";
import type { ProfileView } from "./view";

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

/** Longest text of a value that fits beside its condition on a phone, characters. */
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
export function InWords({ view }: { view: ProfileView }) {
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
