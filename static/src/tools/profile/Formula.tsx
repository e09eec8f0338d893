import { probability } from "../../grid/logOdds";
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

/** The piecewise formula with the numbers of the moment in it. */
export function Formula({ view }: { view: ProfileView }) {
  const values = view.values.value;
  const model = beamModel(values);
  const z = view.z.value;
  const certain = values.model === "moravec_elfes";
  if (view.noReturn.value) {
    return (
      <math class="formula" display="block">
        <mrow>
          <mi>{certain ? "v" : "Δℓ"}</mi>
          <mo>=</mo>
          {values.no_return === "free" ? (
            <mrow>
              <mrow class="noun-miss">
                <mtext>{certain ? "empty: (1 − (s/max range)²) · (1 − (2θ/ω)²)" : signed(model.miss)}</mtext>
              </mrow>
              <mtext>&nbsp; for s ≤ max range = {written(values.range_max, 1)} m</mtext>
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
        <mi>{certain ? "v" : "Δℓ"}</mi>
        <mo>(</mo>
        <mi>{isCone(values) ? "s, θ" : "s"}</mi>
        <mo>)</mo>
        <mo>=</mo>
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
    </math>
  );
}

/** Letters of a value that leave room on a phone for where it holds. */
const SHORT = 8;

interface Row {
  readonly noun: string;
  readonly value: string;
  readonly where: string;
}

/** What a reading adds in each zone, and where the zone is. */
function rowsOf(values: SensorModelParameters, z: number): readonly Row[] {
  const model = beamModel(values);
  const half = halfWindow(z, values);
  const [miss, hit] = [signed(model.miss), signed(model.hit)];
  const before = half > 0 ? `s < z − r/2 = ${written(z - half, 2)} m` : `s < z = ${written(z, 2)} m`;
  const within = half > 0 ? `|s − z| ≤ r/2 = ${written(half, 3)} m` : "the cell that holds z";
  const row = (noun: string, value: string, where: string): Row => ({ noun: `noun-${noun}`, value, where });
  const beyond = row("prior", "0", isCone(values) ? "beyond, and outside ω" : "beyond");
  switch (values.model) {
    case "step_window":
      return [
        row("miss", `logit ${written(values.p_free, 2)} − ℓ₀ = ${miss}`, before),
        row("hit", `logit ${written(values.p_occ, 2)} − ℓ₀ = ${hit}`, within),
        beyond,
      ];
    case "smooth_ramp":
      return [
        row("miss", miss, `s < z − 2σ = ${written(z - half, 2)} m, σ = ${written(half / 2, 3)} m`),
        row("hit", `${miss} → ${hit} → 0`, `up to z, down to z + 2σ = ${written(z + half, 2)} m`),
        beyond,
      ];
    case "hit_counting":
      return [
        row("miss", `ln w(1−p₀) − ln (1 + w(1−p₀)) = ${miss}`, `first visit: ${before}`),
        row("hit", `ln (1 + wp₀) − ln wp₀ = ${hit}`, `first visit: ${within}`),
        row("prior", "p = (n + wp₀) / (n + m + w)", "after n hits, m misses"),
      ];
    case "sonar_cone": {
      const fades = values.cone_profile === "gaussian";
      return [
        row("miss", fades ? `${miss} · (1 − (s/(z−r/2))²) · e^(−8(θ/ω)²)` : miss, before),
        row("hit", fades ? `${hit} · (1 − ((s−z)/(r/2))²) · e^(−8(θ/ω)²)` : hit, within),
        beyond,
      ];
    }
    case "moravec_elfes":
      return [
        row("miss", "empty: (1 − (s/(z−r/2))²) · (1 − (2θ/ω)²)", before),
        row("hit", "occupied: (1 − ((s−z)/(r/2))²) · (1 − (2θ/ω)²)", within),
        beyond,
      ];
    default:
      return [row("miss", miss, before), row("hit", hit, within), beyond];
  }
}

const many = (count: number): string => (count === 1 ? "1 cell" : `${count} cells`);

/** The same in words. */
export function InWords({ view }: { view: ProfileView }) {
  const values = view.values.value;
  const model = beamModel(values);
  const prior = values.log_odds_prior;
  const inWindow = hitCells(view.z.value, values);
  const p = (evidence: number): string => written(probability(prior + evidence), 2);
  if (!inWindow) {
    return values.no_return === "free" ? (
      <p>
        <b class="noun-beam">No echo</b> came back within {written(values.range_max, 1)} m, and the setting “no return”
        takes that as evidence:{" "}
        {isCone(values) ? "all cells of the cone" : `all ${cellIndexAt(values.range_max, values.resolution) + 1} cells`}{" "}
        up to the max range are <b class="noun-miss">passed</b>
        {values.model === "moravec_elfes"
          ? ", surest near the sensor and on the axis."
          : ` and get ${signed(model.miss)}.`}
      </p>
    ) : (
      <p>
        <b class="noun-beam">No echo</b> came back within {written(values.range_max, 1)} m. With “no return” on ignore,
        the map learns nothing from this beam.
      </p>
    );
  }
  const hits = inWindow[1] - inWindow[0] + 1;
  if (values.model === "moravec_elfes") {
    return (
      <p>
        An echo from <b class="noun-beam">z = {written(view.z.value, 2)} m</b>, anywhere on the arc. Closer, the cone is{" "}
        <b class="noun-miss">probably empty</b>, surest near the sensor and on the axis. On the arc{" "}
        <b class="noun-hit">something stands</b>: cells known to be empty are taken out, the others share one certainty
        of 1. They are combined by the rules of 1985, no log-odds that are added.
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
      The beam came back from <b class="noun-beam">z = {written(view.z.value, 2)} m</b>. It{" "}
      <b class="noun-miss">passed {many(inWindow[0])}</b>: one never seen before goes from p {p(0)} to {p(model.miss)}.
      {values.model === "smooth_ramp" ? (
        <>
          {" "}
          In the {many(hits)} around its end <b class="noun-hit">free turns into occupied</b>, up to p {p(model.hit)}{" "}
          where it ended, and fades away.
        </>
      ) : (
        <>
          {" "}
          It <b class="noun-hit">ended in {hits === 1 ? "1 cell" : `the window, ${hits} cells`}</b>: p {p(0)} becomes{" "}
          {p(model.hit)}.
        </>
      )}{" "}
      Of what lies <b class="noun-prior">beyond</b> it says nothing.
    </p>
  );
}
