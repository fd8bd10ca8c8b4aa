"""Draw the plots of the flat fish: `python docs/make_flat_pictures.py [FOLDER]`.

The plots of `subsea-capture flat --plots FOLDER` as small files, after as long a time.
"""

from matplotlib import rc_context
from matplotlib.figure import Figure
from picture_files import STYLE, output_folder, save_plot

from capture.flat.experiments import EXPERIMENTS
from capture.flat.lessons import Effort, FlatLearner
from capture.flat.scaffold import read_scaffold

if __name__ == "__main__":
    folder, learner = output_folder(), FlatLearner(read_scaffold(), Effort())
    with rc_context(STYLE):
        for name, experiment in EXPERIMENTS.items():
            lines, draw = experiment(learner)
            print("\n".join(lines))
            page = Figure(layout="constrained")
            draw(page)
            save_plot(page, folder / f"flat_{name}.png")
