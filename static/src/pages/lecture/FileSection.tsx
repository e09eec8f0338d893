import { Thresholds } from "../../lessons/thresholds/Thresholds";
import { Section, type SectionHead } from "./Section";

export function FileSection({ id, number, title }: SectionHead) {
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
            The thresholds in the yaml file are not the ones that you drag, and this is correct: yours decide what is
            written to the image, those in the yaml file say how to read it. With negate 0 a reader computes the
            occupancy as (255 − grey) / 255. This is 1 for an occupied cell (grey 0), 0.004 for a free cell (grey 254)
            and <b>0.196</b> for an unknown cell (grey 205). A cell below free_thresh is read as free. Move the reader’s
            free_thresh above 0.196: the image does not change, but the unknown cells are read as free, and a planner
            may drive through them. This happens in practice: until 2025 Nav2’s map_saver wrote 0.25 by default. This
            mapper writes 0.196, as map_saver does now, and reports a file with a higher value when it reads one.
          </p>
          <p>
            The first row of the image is the top of the map, the first row of the grid is the bottom, so the rows are
            written in reverse order. The origin in the yaml file is the lower left corner of the map, in metres.
          </p>
        </>
      }
    >
      <p>
        A path planner needs to know where the robot may drive, not probabilities. So two thresholds divide the cells
        into <b class="noun-miss">free</b>, <b class="noun-prior">unknown</b> and <b class="noun-hit">occupied</b>, and
        the map is saved as an image with three grey values and a short yaml file. Nav2’s map_server loads these two
        files. Drag the thresholds in the histogram of this small map, which is made from six noisy scans. The height of
        a bar is the square root of its count, so that small counts can be seen.
      </p>
    </Section>
  );
}
