import { signal } from "@preact/signals";
import { logOdds, probability } from "../../grid/logOdds";
import { cellParameters, parameters, setParameter } from "../../lessons/common/parameters";
import { Profile } from "../../tools/profile/Profile";
import { Choice } from "../../ui/Choice";
import { DragNumber } from "../../ui/DragNumber";
import { signed, written } from "../../ui/numbers";
import { Section, type SectionHead } from "./Section";
import { SectionLink } from "./SectionLink";

const noBeam = signal(undefined);

const MODELS = [
  { value: "step_window", label: "step window in probabilities" },
  { value: "fixed_increments", label: "fixed increments" },
  { value: "smooth_ramp", label: "smooth ramp" },
  { value: "sonar_cone", label: "sonar cone" },
  { value: "moravec_elfes", label: "Moravec and Elfes 1985" },
  { value: "hit_counting", label: "hit counting" },
];

/** Each model in one sentence. */
const DESCRIPTIONS: Record<string, string> = {
  fixed_increments:
    "Two log-odds increments: one for the cells that a beam passed, one for the cell in which it ended.",
  step_window:
    "Table 9.2 of Probabilistic Robotics: three probabilities, before the window, inside it, and the prior beyond it.",
  smooth_ramp: "A reading has an uncertainty σ that grows with the range: the step becomes a ramp.",
  sonar_cone:
    "A wide beam, seen from above: the evidence depends on distance and angle. The section on sonar makes a map with it.",
  moravec_elfes:
    "Two degrees of certainty instead of log-odds: empty and occupied. The section on sonar shows how they are combined.",
  hit_counting:
    "Counts how often a beam ended in a cell and how often one passed it; the curve shows the change by the first visit.",
};

export function ModelSection({ id, number, title }: SectionHead) {
  const { window: r, range_max, p_free, p_occ, log_odds_prior } = cellParameters.value;
  const model = String(parameters.value.model);
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={
        <>
          <div class="model-head">
            <Choice label="Model" options={MODELS} value={model} onChange={(value) => setParameter("model", value)} />
            <p>{DESCRIPTIONS[model]}</p>
          </div>
          <Profile parameters={parameters} setParameter={setParameter} reading={noBeam} />
        </>
      }
      sources={[
        ["probabilistic-robotics", "table 9.2"],
        ["octomap", "section 5.1, for the fixed increments"],
        ["elfes", "for the ramp"],
        ["moravec-elfes", ""],
        ["reflection-maps", "for hit counting"],
      ]}
      after={
        <p>
          With fixed increments, the cell of <SectionLink to="cell" /> and the map on the stage use the numbers set
          here: change the curve and compare. The more reliable the sensor, the larger the increments. The model is
          called <em>inverse</em> because a forward model predicts the reading from the world, while this model goes
          from a reading to the world. It is a design choice, not a physical law. If the increments are too large, the
          map follows every wrong reading; if they are too small, cells remain unknown for a long time. The mapper’s
          defaults are a window of 0 and a max range of 30 m; here both are set so that they can be seen at this scale.
        </p>
      }
    >
      <p>
        The filter needs the probability of a cell given a single reading. This is the{" "}
        <b class="noun-beam">inverse sensor model</b>. The simplest one has three values. A beam with the measured range{" "}
        <b class="noun-beam">z</b> passed through all cells before z: for these it says <b class="noun-miss">p_free</b>,
        here {written(p_free, 2)}. The surface that reflected the beam lies in a window of{" "}
        <DragNumber
          label="hit window r"
          sentence="Width of the zone around the reading that counts as hit."
          value={r}
          unit="m"
          tone="hit"
          low={0}
          high={2}
          step={0.05}
          onInput={(value) => setParameter("window", value)}
        />{" "}
        around z; for the cells there it says <b class="noun-hit">p_occ</b>, here {written(p_occ, 2)}. About the cells
        behind the window it says nothing, so they keep the <b class="noun-prior">prior</b>, p_prior ={" "}
        {written(probability(log_odds_prior), 2)}. A reading beyond{" "}
        <DragNumber
          label="max range"
          sentence="A reading from farther away counts as no return."
          value={range_max}
          unit="m"
          tone="prior"
          low={0.5}
          high={20}
          step={0.1}
          onInput={(value) => setParameter("range_max", value)}
        />{" "}
        counts as no return.
      </p>
      <p>
        In log-odds each value becomes a number to add, log p/(1 − p) − ℓ₀: {signed(logOdds(p_free))} for p_free,{" "}
        {signed(logOdds(p_occ))} for p_occ, and 0 for the prior. This is the model <em>step window in probabilities</em>
        . Many programs set the two increments directly, as <em>fixed increments</em> do. Drag any part of the curve;
        the row below it shows the cells of one beam.
      </p>
    </Section>
  );
}
