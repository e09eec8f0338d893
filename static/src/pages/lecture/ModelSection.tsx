import { signal } from "@preact/signals";
import { Profile } from "../../tools/profile/Profile";
import { Choice } from "../../ui/Choice";
import { Scrub } from "../../ui/Scrub";
import { cellParameters, parameters, setParameter } from "./parameters";
import { Section } from "./Section";

const noBeam = signal(undefined);

const MODELS = [
  { value: "fixed_increments", label: "fixed increments" },
  { value: "step_window", label: "step window in probabilities" },
  { value: "smooth_ramp", label: "smooth ramp" },
  { value: "sonar_cone", label: "sonar cone" },
  { value: "moravec_elfes", label: "Moravec and Elfes 1985" },
  { value: "hit_counting", label: "hit counting" },
];

/** What each model says, in a sentence. */
const WORDS: Record<string, string> = {
  fixed_increments: "Two numbers, in log-odds: one for a cell that was passed, one for a cell in which a beam ended.",
  step_window: "The textbook’s table 9.2: three probabilities, before the window, in it, and the prior beyond.",
  smooth_ramp: "A reading is uncertain by σ, and the more so the farther it comes from: the step becomes a ramp.",
  sonar_cone: "A wide beam, seen from above: evidence in two dimensions. Section 7 maps with it.",
  moravec_elfes: "Degrees of certainty, no log-odds: one for empty, one for occupied. Section 7 combines them.",
  hit_counting:
    "Counts how often a beam ended in a cell and how often one passed; shown is what the first visit changes.",
};

export function ModelSection({ id, number, title }: { id: string; number: number; title: string }) {
  const { window: r, range_max } = cellParameters.value;
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
            <p class="quiet">{WORDS[model]}</p>
          </div>
          <Profile parameters={parameters} setParameter={setParameter} reading={noBeam} />
        </>
      }
      sources={[
        ["probabilistic-robotics", "section 9.2 and table 9.2"],
        ["octomap", "section 5.1, for the fixed increments"],
        ["elfes", "for the ramp"],
        ["moravec-elfes", ""],
        ["reflection-maps", "for hit counting"],
      ]}
      after={
        <p>
          With fixed increments the cell of section 2 takes its numbers from here: change the curve, and look back. The
          word <em>inverse</em> is meant literally. A sensor turns a world into readings; this goes the other way, from
          a reading to the world, and it is a choice of the engineer, not a law. Too bold a model believes every stray
          reading; too shy a one never makes up its mind.
        </p>
      }
    >
      <p>
        The filter asks one thing of us: what does a single reading say of a cell? The answer is the{" "}
        <b class="noun-beam">inverse sensor model</b>. A beam that came back from <b class="noun-beam">z</b> passed
        everything before z, so those cells get evidence for <b class="noun-miss">free</b>. Around z, in a window{" "}
        <Scrub
          label="hit window r"
          sentence="How wide the zone around the reading is that counts as hit."
          value={r}
          unit="m"
          tone="hit"
          low={0}
          high={2}
          step={0.05}
          onInput={(value) => setParameter("window", value)}
        />{" "}
        wide, stands what sent it back: <b class="noun-hit">occupied</b>. Of all <b class="noun-prior">behind</b> it,
        the beam says nothing. And what comes from beyond{" "}
        <Scrub
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
        counts as no return at all.
      </p>
      <p>Take hold of the curve: every part of it can be dragged, and below it the cells of one beam answer.</p>
    </Section>
  );
}
