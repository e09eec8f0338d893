import { logOdds, probability } from "../../../grid/cellValues";
import { cellParameters, parameters, setParameter } from "../../../lessons/common/parameters";
import { modelReading } from "../../../lessons/stage/controls";
import { modelBeam, modelCone } from "../../../lessons/stage/scenes";
import { readable } from "../../../tools/parameters/parameters";
import { Profile } from "../../../tools/profile/Profile";
import { Choice } from "../../../ui/Choice";
import { DragNumber } from "../../../ui/DragNumber";
import { signed, written } from "../../../ui/numbers";
import { OnStage, Section, type SectionHead, SectionLink } from "../Section";

/** Each model in one sentence. */
const DESCRIPTIONS: Readonly<Record<string, string>> = {
  step_window:
    "Table 9.2 of Probabilistic Robotics: a probability before the window, one inside it, the prior behind it.",
  fixed_increments:
    "Two log-odds increments: one for the cells that a beam passed, one for the cell in which it ended.",
  smooth_ramp: "A reading has an uncertainty σ that grows with the range: the step becomes a ramp.",
  sonar_cone: "A wide beam, seen from above: the evidence depends on distance and angle.",
  moravec_elfes: "Two degrees of certainty instead of log-odds: empty and occupied.",
  hit_counting:
    "Counts how often a beam ended in a cell and how often one passed it; the curve shows the change by the first visit.",
};

const MODELS = Object.keys(DESCRIPTIONS).map((value) => ({ value, label: readable(value) }));

export function ModelSection(head: SectionHead) {
  const { window: w, range_max, p_free, p_occ, log_odds_prior } = cellParameters.value;
  const model = String(parameters.value.model);
  const beam = modelCone.value ? "cone" : "beam";
  return (
    <Section
      {...head}
      figure={
        <OnStage scene="model" label="The inverse sensor model as a curve, and the map that it makes">
          <div class="model-head">
            <Choice label="Model" options={MODELS} value={model} onChange={(value) => setParameter("model", value)} />
            <p>{DESCRIPTIONS[model]}</p>
          </div>
          <Profile
            parameters={parameters}
            setParameter={setParameter}
            reading={modelBeam}
            where="on the stage"
            grabbed={modelReading}
          />
        </OnStage>
      }
      sources={[
        ["probabilistic-robotics", "table 9.2"],
        ["octomap", "section 5.1 (fixed increments)"],
        ["elfes", "(ramp)"],
        "moravec-elfes",
        ["reflection-maps", "(hit counting)"],
      ]}
      after={
        <p>
          A forward model predicts readings from the world; an <em>inverse</em> one infers the world from a reading. It
          is a design choice, not a physical law: the more reliable the sensor, the larger the increments. Too large,
          and the map follows every wrong reading; too small, and cells stay unknown for long.
        </p>
      }
    >
      <p>
        The filter needs the probability of a cell given a single reading: the{" "}
        <b class="noun-beam">inverse sensor model</b>. The simplest one has three values. A beam with the measured range{" "}
        <b class="noun-beam">
          <i>z</i>
        </b>{" "}
        passed all cells before the window around <i>z</i>, so they get{" "}
        <b class="noun-miss">
          <i>p</i>
          <sub>free</sub>
        </b>{" "}
        = {written(p_free, 2)}. The surface that reflected it lies in a window of width <i>w</i> ={" "}
        <DragNumber
          label="hit window w"
          sentence="Width of the zone around the reading that counts as hit."
          value={w}
          unit="m"
          tone="hit"
          low={0}
          high={2}
          step={0.05}
          onInput={(value) => setParameter("window", value)}
        />{" "}
        around <i>z</i>, whose cells get{" "}
        <b class="noun-hit">
          <i>p</i>
          <sub>occ</sub>
        </b>{" "}
        = {written(p_occ, 2)}. Cells behind the window keep the <b class="noun-prior">prior</b>,{" "}
        {written(probability(log_odds_prior), 2)}: the beam says nothing about them. A reading beyond{" "}
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
        As log-odds to add, these are logit <i>p</i> − ℓ₀, with logit <i>p</i> = log(<i>p</i>/(1&nbsp;−&nbsp;<i>p</i>)):{" "}
        {signed(logOdds(p_free))}, {signed(logOdds(p_occ))} and 0. Many programs set the two increments directly, as{" "}
        <SectionLink to="cell" /> does (<em>fixed increments</em>: −0.40, +0.85). The curve is that of one {beam} of the
        stage. <span class="no-print">Drag any part of it: the {beam}, its cells and the whole map follow.</span>
      </p>
    </Section>
  );
}
