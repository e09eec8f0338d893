import { Pipeline } from "../../lessons/pipeline/Pipeline";
import { OnStage } from "./OnStage";
import { Section, type SectionHead } from "./Section";

export function PipelineSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={
        <OnStage scene="pipeline" label="The steps from one reading to a character">
          <Pipeline />
        </OnStage>
      }
      sources={["laser-scan", "bresenham"]}
    >
      <p>
        The program has two loops: the outer one over the <b>scans</b>, each with its pose, the inner one over the{" "}
        <b class="noun-beam">beams</b> of a scan. Each reading goes through the same steps. Go through them one by one;
        the stage shows each step, and the slider selects another beam.
      </p>
    </Section>
  );
}
