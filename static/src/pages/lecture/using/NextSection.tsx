import { Button } from "../../../ui/Button";
import { OnStage, Section, type SectionHead, SectionLink } from "../Section";
import { SOURCES } from "../sources";

export function NextSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={
        <OnStage scene="next" label="The map of the whole drive">
          <div class="actions no-print">
            <Button kind="primary" icon="file" href="/logs.html">
              Map your own log
            </Button>
            <Button href="/lab.html">Drive a robot in the lab</Button>
            <Button href="/puzzles.html">Solve a puzzle</Button>
          </div>
        </OnStage>
      }
      sources={["montemerlo", "gmapping", "slam-toolbox", "hess", "mildenhall", "kerbl"]}
      after={
        <details class="lecture-sources">
          <summary>All sources of the lecture</summary>
          <ul>
            {Object.entries(SOURCES).map(([name, source]) => (
              <li key={name}>{source}.</li>
            ))}
          </ul>
        </details>
      }
    >
      <ul>
        <li>
          <b>FastSLAM</b> gives every particle of <SectionLink to="particles" /> a map of landmarks of its own.
        </li>
        <li>
          <b>Grid-based SLAM</b>, as in gmapping, does the same with occupancy grids.
        </li>
        <li>
          <b>Graph-based SLAM</b>, as in SLAM Toolbox and Cartographer, corrects all poses at once, as in{" "}
          <SectionLink to="graph" />.
        </li>
        <li>
          <b>Neural fields</b> store the look or shape of a place in the weights of a network, and are slow to update.
        </li>
        <li>
          <b>Gaussian splats</b> store how it looks from every side; like point clouds, they do not say what is free.
        </li>
      </ul>
      <p>
        In <cite>Probabilistic Robotics</cite>: sections 4.2, 9.1, 9.2 (mapping), chapters 5–8 (motion, sensors,
        localization), 10–13 (SLAM).
      </p>
    </Section>
  );
}
