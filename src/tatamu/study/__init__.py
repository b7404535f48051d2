"""Studies: the options of learning, the loop over trials, the storage of trials, and the results of studies.

A study is one search for a fold, and a trial is one evaluation in this search.
"""
