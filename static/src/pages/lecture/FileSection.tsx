import { Thresholds } from "../../lessons/thresholds/Thresholds";
import { Section } from "./Section";

export function FileSection({ id, number, title }: { id: string; number: number; title: string }) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<Thresholds />}
      sources={[
        ["map-server", ""],
        ["occupancy-grid", ""],
      ]}
      after={
        <>
          <p>
            The yaml does not state the thresholds that you drag, and that is no mistake: those decided what was
            written, these say how to read it. With negate 0 a reader computes (255 − grey) / 255, which is 1 for the 0
            of an occupied cell, 0.004 for the 254 of a free one, and <b>0.196</b> for the 205 of an unknown one; less
            than free_thresh is free. Move the reader’s free_thresh above that number and see what becomes of the
            unknown: the image is the same, and the planner drives through it. That is no rare accident: until 2025 the
            map_saver of Nav2 wrote 0.25 unless it was told otherwise. This mapper writes 0.196, as map_saver does now,
            and where it reads such a file it says so.
          </p>
          <p>
            The image has its top row first and the grid its lowest; the file is flipped on its way, and the origin in
            the yaml is the lower left corner, in metres.
          </p>
        </>
      }
    >
      <p>
        A planner wants no probabilities; it wants to know where it may drive. So the map is cut at two thresholds into{" "}
        <b class="noun-miss">free</b>, <b class="noun-prior">unknown</b> and <b class="noun-hit">occupied</b>, and saved
        as an image of three greys with a few lines of yaml beside it. That is the file that Nav2’s map_server loads.
        Drag the thresholds across the cells of this small map, made of six noisy scans; its bars are drawn by the root
        of their count, so that the rare ones can be seen.
      </p>
    </Section>
  );
}
