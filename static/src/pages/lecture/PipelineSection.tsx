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
        <OnStage scene="pipeline" label="One reading on its way to a character">
          <Pipeline />
        </OnStage>
      }
      sources={["laser-scan", "bresenham"]}
    >
      <p>
        Two loops are around everything: the outer one over the <b>scans</b>, each with its pose, the inner one over the{" "}
        <b class="noun-beam">beams</b> of a scan. What happens to one reading on its way is always the same. Follow it
        step by step; the stage shows each step, and the slider selects another beam.
      </p>
    </Section>
  );
}
