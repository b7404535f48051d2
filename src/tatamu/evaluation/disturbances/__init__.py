"""Disturbances of hands, grasps, cloth and table: their file, random draws of them, and the disturbed scenes."""

from tatamu.evaluation.disturbances.channels import CHANNELS as CHANNELS
from tatamu.evaluation.disturbances.channels import Channel as Channel
from tatamu.evaluation.disturbances.description import Disturbances as Disturbances
from tatamu.evaluation.disturbances.description import default_disturbances as default_disturbances
from tatamu.evaluation.disturbances.description import disturbances_in as disturbances_in
from tatamu.evaluation.disturbances.description import load_disturbances as load_disturbances
from tatamu.evaluation.disturbances.description import read_disturbances as read_disturbances
from tatamu.evaluation.disturbances.description import require_disturbances as require_disturbances
from tatamu.evaluation.disturbances.description import with_calibrated as with_calibrated
from tatamu.evaluation.disturbances.disturbed import disturbed_hands as disturbed_hands
from tatamu.evaluation.disturbances.disturbed import disturbed_scene as disturbed_scene
from tatamu.evaluation.disturbances.disturbed import hand_errors as hand_errors
from tatamu.evaluation.disturbances.disturbed import hand_failure as hand_failure
from tatamu.evaluation.disturbances.scenario import NOMINAL as NOMINAL
from tatamu.evaluation.disturbances.scenario import Scenario as Scenario
from tatamu.evaluation.disturbances.scenario import Stream as Stream
from tatamu.evaluation.disturbances.scenario import deviations as deviations
from tatamu.evaluation.disturbances.scenario import mean_scenario as mean_scenario
from tatamu.evaluation.disturbances.scenario import sample_scenarios as sample_scenarios
from tatamu.evaluation.disturbances.systematic import Split as Split
from tatamu.evaluation.disturbances.systematic import join as join
from tatamu.evaluation.disturbances.systematic import split as split
