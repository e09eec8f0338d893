import { signal } from "@preact/signals";
import { Profile } from "../../figures/profile/Profile";
import { Scrub } from "../../ui/Scrub";
import { cellParameters, parameters, setParameter } from "./parameters";
import { Section } from "./Section";

const noBeam = signal(undefined);

export function ModelSection({ id, number, title }: { id: string; number: number; title: string }) {
  const { window: r, range_max } = cellParameters.value;
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<Profile parameters={parameters} setParameter={setParameter} reading={noBeam} />}
      sources={[
        ["probabilistic-robotics", "section 9.2 and table 9.2"],
        ["octomap", "section 3.2"],
      ]}
      after={
        <p>
          The cells of section 2 take their increments from here: change the curve, and look back. The word{" "}
          <em>inverse</em> is meant literally. A sensor turns a world into readings; this goes the other way, from a
          reading to the world, and it is a choice of the engineer, not a law. Too bold a model believes every stray
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
