import { signed, written } from "../../ui/numbers";
import { beamModel, cellAt, hitCells, probability } from "./model";
import type { ProfileView } from "./view";

/** The piecewise formula with the numbers of the moment in it. */
export function Formula({ view }: { view: ProfileView }) {
  const values = view.values.value;
  const model = beamModel(values);
  const z = view.z.value;
  const step = values.model === "step_window";
  const half = values.window / 2;
  if (view.noReturn.value) {
    return (
      <math class="formula" display="block">
        <mrow>
          <mi>Δℓ</mi>
          <mo>=</mo>
          {values.no_return === "free" ? (
            <mrow>
              <mrow class="noun-miss">
                <mn>{signed(model.miss)}</mn>
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
  return (
    <math class="formula" display="block">
      <mrow>
        <mi>Δℓ</mi>
        <mo>(</mo>
        <mi>s</mi>
        <mo>)</mo>
        <mo>=</mo>
        <mtable>
          <mtr>
            <mtd>
              <mrow class="noun-miss">
                {step && <mtext>{`logit ${written(values.p_free, 2)} − ℓ₀ = `}</mtext>}
                <mn>{signed(model.miss)}</mn>
              </mrow>
            </mtd>
            <mtd>
              <mtext>
                {values.window > 0 ? `s < z − r/2 = ${written(z - half, 2)} m` : `s < z = ${written(z, 2)} m`}
              </mtext>
            </mtd>
          </mtr>
          <mtr>
            <mtd>
              <mrow class="noun-hit">
                {step && <mtext>{`logit ${written(values.p_occ, 2)} − ℓ₀ = `}</mtext>}
                <mn>{signed(model.hit)}</mn>
              </mrow>
            </mtd>
            <mtd>
              <mtext>{values.window > 0 ? `|s − z| ≤ r/2 = ${written(half, 3)} m` : "the cell that holds z"}</mtext>
            </mtd>
          </mtr>
          <mtr>
            <mtd>
              <mrow class="noun-prior">
                <mn>0</mn>
              </mrow>
            </mtd>
            <mtd>
              <mtext>beyond</mtext>
            </mtd>
          </mtr>
        </mtable>
      </mrow>
    </math>
  );
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
        takes that as evidence: all {cellAt(values.range_max, values.resolution) + 1} cells up to the max range are{" "}
        <b class="noun-miss">passed</b> and get {signed(model.miss)}.
      </p>
    ) : (
      <p>
        <b class="noun-beam">No echo</b> came back within {written(values.range_max, 1)} m. With “no return” on ignore,
        the map learns nothing from this beam.
      </p>
    );
  }
  const hits = inWindow[1] - inWindow[0] + 1;
  return (
    <p>
      The beam came back from <b class="noun-beam">z = {written(view.z.value, 2)} m</b>. It{" "}
      <b class="noun-miss">passed {many(inWindow[0])}</b>: one never seen before goes from p {p(0)} to {p(model.miss)}.
      It <b class="noun-hit">ended in {many(hits)}</b>: p {p(0)} becomes {p(model.hit)}. Of what lies{" "}
      <b class="noun-prior">beyond</b> it says nothing.
    </p>
  );
}
