import { signal } from "@preact/signals";
import { STATED } from "../../../lessons/thresholds/model";
import { Thresholds } from "../../../lessons/thresholds/Thresholds";
import { presenting } from "../present/state";
import { Section, type SectionHead } from "../Section";

/** The free_thresh of the text's figure, and that of the slide's question. */
const textReadsFree = signal<number>(STATED.free);
const slideReadsFree = signal(0.25);

export function FileSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={<Thresholds readFree={presenting.value ? slideReadsFree : textReadsFree} />}
      sources={["map-server", "occupancy-grid"]}
      after={
        <>
          <p>
            Your thresholds decide what is written to the image; those in the YAML file say how to read it. A reader
            computes (255 − grey) / 255: 1 for an occupied cell (grey 0), 0.004 for a free one (254) and <b>0.196</b>{" "}
            for an unknown one (205). What is below free_thresh is free. With a free_thresh above 0.196 the unknown
            cells of the same image are read as free, and a planner may drive through them.
          </p>
          <p>The first row of the image is the top of the map, the first row of the grid the bottom.</p>
        </>
      }
    >
      <p>
        A planner needs to know where the robot may drive. Two thresholds divide the cells into{" "}
        <b class="noun-miss">free</b>, <b class="noun-prior">unknown</b> and <b class="noun-hit">occupied</b>, saved as
        an image with three grey values and a YAML file, which Nav2’s map_server loads.{" "}
        <span class="no-print">Drag the thresholds in the histogram.</span>
      </p>
    </Section>
  );
}
